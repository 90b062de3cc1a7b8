# viewimit, for a server behind the proxy of compose.yaml
FROM --platform=linux/amd64 python:3.11-slim-bookworm@sha256:a36c24f9cbdf4fd0f52d67f0823eeac19c2028c637cecc392d97f980d4fec56b
ENV PIP_NO_CACHE_DIR=1 PIP_DISABLE_PIP_VERSION_CHECK=1
WORKDIR /src
COPY deploy/requirements.lock deploy/
RUN pip install --require-hashes --only-binary=:all: -r deploy/requirements.lock
COPY pyproject.toml README.md LICENSE ./
COPY viewimit viewimit
COPY app app
COPY assets assets
RUN pip install --no-deps --no-build-isolation . && useradd --create-home viewimit && install -d -o viewimit /data
USER viewimit
WORKDIR /home/viewimit
EXPOSE 8080
HEALTHCHECK --interval=10s --timeout=3s --start-period=30s \
  CMD ["python", "-c", "import urllib.request, urllib.error as e\ntry: urllib.request.urlopen('http://127.0.0.1:8080/health', timeout=2)\nexcept e.HTTPError: pass"]
STOPSIGNAL SIGTERM
ENTRYPOINT ["viewimit"]
CMD ["serve", "--host", "0.0.0.0"]
