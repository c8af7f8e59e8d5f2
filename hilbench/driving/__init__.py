"""Who speaks to a live bench by hand or by itself: clients, taps on their lines, the demo driver."""
