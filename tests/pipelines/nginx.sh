# SPDX-License-Identifier: LGPL-2.1-or-later
# shellcheck shell=bash disable=SC2154 # work and root are those of support.sh
# Debian's nginx with the lines of docs/web.md. To be sourced after support.sh.
PATH=$PATH:/usr/sbin # where nginx is, and where an ordinary user's shell does not look

# The lines of the page, but for folder and port. Around them is what Debian's /etc/nginx/nginx.conf has.
# `serve FOLDER` sets $address.
serve() {
  local folder=$1 port
  port=$(free_ports 1)
  mkdir -p "$work/nginx"
  cat >"$work/nginx/nginx.conf" <<EOF
daemon off;
worker_processes auto;
worker_rlimit_nofile 4096;
pid $work/nginx/pid;
error_log $work/nginx/error.log;
events { worker_connections 4096; }
http {
  sendfile on;
  tcp_nopush on;
  include /etc/nginx/mime.types;
  default_type application/octet-stream;
  gzip on;
  access_log off;
$(for kind in client_body proxy fastcgi uwsgi scgi; do echo "  ${kind}_temp_path $work/nginx/$kind;"; done)
$(awk '/^```nginx$/ { open = 1; next } /^```$/ && open { exit } open' "$root/docs/web.md" |
    sed "s#root /srv/film;#root $folder;#; s#listen 8080;#listen 127.0.0.1:$port;#")
}
EOF
  nginx -e "$work/nginx/error.log" -c "$work/nginx/nginx.conf" &
  server=$!
  trap 'kill "$server" 2>/dev/null; wait "$server" 2>/dev/null; rm -rf "$work"' EXIT
  address=127.0.0.1:$port
  until curl -s -o "$work/first" "http://$address/film.m3u8"; do
    kill -0 "$server" 2>/dev/null || { cat "$work/nginx/error.log"; return 1; }
    sleep 0.05
  done
}
