"""The independent check of certificates.

Its modules import the standard library, ball arithmetic (Arb, through python-flint) and each other,
and nothing else of Parkproof, so that the folder can be read and run by itself.
"""
