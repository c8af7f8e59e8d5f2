"""What others bring: the record that describes a protocol, and where such records are found."""
