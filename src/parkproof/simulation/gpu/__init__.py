"""The lanes on a graphics processor: one trial a thread, from the same source."""
