"""Mutants: certified tubes and tasks bent or made harder; a certificate must refuse those that an oracle finds unsafe."""
