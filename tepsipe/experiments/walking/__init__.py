"""Impedance of the ankle in the stance phase of walking, by belt pulses at random strides."""
