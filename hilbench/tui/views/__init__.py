"""What is known of a bench as lines of text of a given size; a colour never says anything that the text does not."""
