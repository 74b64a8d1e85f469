"""What a person does to teach a behaviour, each a use case over the store in one module."""
