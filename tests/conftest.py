"""Settings that all tests share."""

from hypothesis import settings

# The same examples at every run: a failure on one machine is a failure on all.
settings.register_profile("repeatable", derandomize=True, deadline=None, database=None)
settings.load_profile("repeatable")
