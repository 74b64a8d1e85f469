"""The inference process as its clients see it: where it answers, its messages, and a client."""

from tril.inference.client import (
    AttentionMap,
    AttentionMethod,
    AttentionNetwork,
    GivenUp,
    InferenceClient,
    Judgement,
)
from tril.inference.endpoint import Endpoint, LocalEndpoint, TcpEndpoint, endpoint_of

__all__ = [
    "AttentionMap",
    "AttentionMethod",
    "AttentionNetwork",
    "Endpoint",
    "GivenUp",
    "InferenceClient",
    "Judgement",
    "LocalEndpoint",
    "TcpEndpoint",
    "endpoint_of",
]
