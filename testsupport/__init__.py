"""What tests, benchmarks and scripts share. It is no part of the distribution."""
