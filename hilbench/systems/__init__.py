"""What is peculiar to one system, a folder each; nothing generic names one of them."""
