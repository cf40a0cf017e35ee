#!/bin/bash
# Exit code 0 if the server in this container answers GET /readyz with 200. bash opens the connection
# itself, so that the image needs no curl. A server on another port than 8080 sets SIGHTLINE_PORT.
exec 3<>"/dev/tcp/127.0.0.1/${SIGHTLINE_PORT:-8080}" || exit 1
printf 'GET /readyz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n' >&3
read -r -t 2 _ status _ <&3
[ "$status" = 200 ]
