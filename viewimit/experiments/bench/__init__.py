"""Benchmarks and studies behind the figures of README, each reproducible from a seed. They judge nothing
by the paper."""
