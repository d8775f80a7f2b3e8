"""The command line; main.py joins the commands."""
