"""The dummy that the thesis's printed tables describe: an inverse problem."""
