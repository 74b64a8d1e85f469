# One image for the three services of docker-compose.yml. Every RUN step is a target of the
# Makefile that `make run` goes through too.
#
# torch's plain Linux package carries several GB of CUDA libraries. A machine without an NVIDIA GPU
# can take the small build: pass the index named on PyTorch's installation page for "CPU" with
#   docker compose build --build-arg PIP_EXTRA_INDEX_URL=...

FROM python:3.11-bookworm AS build
ARG PIP_EXTRA_INDEX_URL=""
ENV PIP_NO_CACHE_DIR=1
WORKDIR /data
WORKDIR /opt/tril
COPY Makefile pyproject.toml constraints.txt README.md LICENSE ./
COPY scripts scripts
COPY tril/__init__.py tril/
RUN make environment

FROM python:3.11-bookworm AS page
ENV PIP_NO_CACHE_DIR=1
WORKDIR /opt/tril
COPY Makefile pyproject.toml constraints.txt .npmrc ./
COPY scripts scripts
COPY frontend frontend
RUN make frontend

FROM python:3.11-slim-bookworm
ENV PATH=/opt/tril/.venv/bin:$PATH \
    PYTHONDONTWRITEBYTECODE=1 \
    PYTHONUNBUFFERED=1 \
    TRIL_DATA=/data \
    TRIL_HOST=0.0.0.0
COPY --from=build --chown=10001:10001 /data /data
WORKDIR /opt/tril
COPY --from=build /opt/tril ./
COPY migrations migrations
COPY tril tril
COPY server server
COPY --from=page /opt/tril/server/web/static server/web/static
COPY trainer trainer
COPY cli cli
USER 10001:10001
VOLUME /data
EXPOSE 8000
CMD ["tril", "serve"]
