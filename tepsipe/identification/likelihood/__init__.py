"""Likelihood of all motion channels of a trial on the treadmill: markers of leg and foot, belt velocity."""
