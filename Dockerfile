# viewimit's page, for one replica behind the proxy of compose.yaml
FROM --platform=linux/amd64 python:3.11-slim-bookworm@sha256:a36c24f9cbdf4fd0f52d67f0823eeac19c2028c637cecc392d97f980d4fec56b
WORKDIR /src
COPY deploy/requirements.lock deploy/install.sh deploy/
COPY pyproject.toml build_backend.py setup.py README.md LICENSE ./
COPY viewimit viewimit
COPY app app
COPY assets assets
RUN sh deploy/install.sh && useradd --create-home viewimit
USER viewimit
WORKDIR /home/viewimit
EXPOSE 8080
HEALTHCHECK --interval=10s --timeout=3s --start-period=30s \
  CMD ["python", "-c", "import urllib.request; urllib.request.urlopen('http://127.0.0.1:8080/health', timeout=2)"]
STOPSIGNAL SIGTERM
ENTRYPOINT ["viewimit", "serve", "--host", "0.0.0.0"]
