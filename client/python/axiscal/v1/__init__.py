"""Messages of the API, package axiscal.v1 (proto/README.md): made by protoc when the package is built."""
