"""How a bench in real time keeps up, and how those behind its ports do."""
