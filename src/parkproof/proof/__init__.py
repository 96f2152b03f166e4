"""What can be proved of the gains: conditions, searches."""
