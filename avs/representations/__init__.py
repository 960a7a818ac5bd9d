"""What can be fitted to views and rendered."""
