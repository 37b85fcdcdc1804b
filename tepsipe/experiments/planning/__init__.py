"""What an experiment on the treadmill will show, before it is done."""
