# pcsmooth with its kernels compiled, so that no run has to:
#   docker build -t pcsmooth .
#   docker run --rm -v "$PWD:/data" pcsmooth denoise scan.ply -o smooth.ply
# The kernels are compiled for processors with AVX2, wherever the image is built; on others, and
# for users other than 1000, whose cache it is not, each run compiles.
FROM python:3.12-slim
COPY . /source
RUN pip install --no-cache-dir "/source[las,e57]" && rm -rf /source \
    && useradd --uid 1000 --create-home pcsmooth
USER pcsmooth
ENV NUMBA_CPU_NAME=x86-64-v3
RUN pcsmooth warmup --all
WORKDIR /data
ENTRYPOINT ["pcsmooth"]
