"""The simulated pictures against real ones, and how long they take."""
