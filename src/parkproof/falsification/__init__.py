"""The search for the run that breaks a claim, or comes nearest to a bound."""
