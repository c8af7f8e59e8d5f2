"""What answers at the far end of a link: behavioural robot controllers now, emulated microcontrollers later."""
