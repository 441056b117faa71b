# pcsmooth with its kernels compiled, so that no run has to:
#   docker build -t pcsmooth .
#   docker run --rm -v "$PWD:/data" pcsmooth denoise scan.ply -o smooth.ply
# It runs as user 1000, or as whoever is to own what it writes: --user "$(id -u):$(id -g)".
# --build-arg EXTRAS=all adds pictures, pages and dask.
#
# The kernels are root's, and in lib/pcsmooth of the environment, where every user's runs find them.
# They are for processors with AVX2, wherever the image is built; on others a run compiles its own.
FROM python:3.13-slim AS build
ARG EXTRAS=e57
ENV NUMBA_CPU_NAME=x86-64-v3
RUN python -m venv --without-pip /opt/pcsmooth
COPY . /source
RUN pip --python /opt/pcsmooth install --no-cache-dir "/source[$EXTRAS]" \
    && find /opt/pcsmooth -type d -name tests -prune -exec rm -r {} +
RUN NUMBA_CACHE_DIR=/opt/pcsmooth/lib /opt/pcsmooth/bin/pcsmooth warmup --all \
    && chmod -R a+rX,go-w /opt/pcsmooth

FROM python:3.13-slim
COPY --from=build /opt/pcsmooth /opt/pcsmooth
# A user without a name in the image has no home of its own.
ENV PATH=/opt/pcsmooth/bin:$PATH HOME=/tmp NUMBA_CPU_NAME=x86-64-v3
USER 1000:1000
WORKDIR /data
ENTRYPOINT ["pcsmooth"]
