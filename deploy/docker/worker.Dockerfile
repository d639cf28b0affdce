# syntax=docker/dockerfile:1
# One worker image per service.
#   docker build -f deploy/docker/worker.Dockerfile --build-arg SERVICE=segmentation -t shapery-segmentation .

FROM python:3.12-slim-bookworm AS build
ARG SERVICE
ENV PIP_NO_CACHE_DIR=1 PIP_DISABLE_PIP_VERSION_CHECK=1
RUN case "$SERVICE" in segmentation|retrieval|motion) ;; \
        *) echo "--build-arg SERVICE must be segmentation, retrieval or motion" >&2; exit 1 ;; esac
RUN python -m venv /opt/shapery
ENV PATH=/opt/shapery/bin:$PATH
COPY "deploy/locks/${SERVICE}.lock" /src/worker.lock
RUN pip install --require-hashes -r /src/worker.lock
RUN python -m venv /opt/build && /opt/build/bin/pip install "hatchling>=1.27"
COPY shared/contracts /src/shared/contracts
COPY shared/geometry /src/shared/geometry
COPY shared/platform /src/shared/platform
COPY "services/${SERVICE}" "/src/services/${SERVICE}"
COPY worker /src/worker
RUN for member in shared/contracts shared/geometry shared/platform "services/${SERVICE}" worker; do \
        /opt/build/bin/hatchling build -t wheel -d /wheels "/src/$member" || exit 1; \
    done; \
    pip install --no-deps /wheels/*.whl
# Compile the kernels once, while the image is built; the entry point copies them to where they may be written.
ENV NUMBA_CACHE_DIR=/opt/kernels
RUN mkdir -p "$NUMBA_CACHE_DIR" && \
    if python -c "import importlib.util, sys; sys.exit(importlib.util.find_spec('shapery_${SERVICE}.warm') is None)"; \
    then python -m "shapery_${SERVICE}.warm"; fi

FROM python:3.12-slim-bookworm
ARG SERVICE
LABEL org.opencontainers.image.title="shapery-${SERVICE}" org.opencontainers.image.licenses="Apache-2.0"
RUN useradd --system --uid 10001 --no-create-home --shell /usr/sbin/nologin shapery
COPY --from=build /opt/shapery /opt/shapery
COPY --from=build /opt/kernels /opt/kernels
COPY --chmod=0755 deploy/docker/worker-entrypoint.sh /usr/local/bin/worker-entrypoint
ENV PATH=/opt/shapery/bin:$PATH \
    PYTHONUNBUFFERED=1 \
    PYTHONDONTWRITEBYTECODE=1 \
    NUMBA_CACHE_DIR=/tmp/kernels \
    SHAPERY_PROFILE=production \
    SHAPERY_SCRATCH=/tmp \
    SHAPERY_SERVICE=${SERVICE}
USER 10001
# The root file system may be mounted read-only; only /tmp is written to.
HEALTHCHECK --interval=15s --timeout=10s --start-period=30s --retries=3 CMD ["shapery-worker", "health"]
ENTRYPOINT ["worker-entrypoint"]
CMD ["run"]
