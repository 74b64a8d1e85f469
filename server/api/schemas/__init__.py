"""The bodies of requests and responses; the frontend's types are generated from them."""
