"""Benchmark with a hidden truth: its problems as a method reads them, and methods that answer them."""
