# SPDX-License-Identifier: LGPL-2.1-or-later
# The configurations of sweep.csv that no other of the same side beats in both time and error, by time, with one
# thread: time, error, its 95 % interval, the time's 99th percentile, and a name where there is room for one.
#
#   awk -f pareto.awk -v stratum=pairs -v peers=1 sweep.csv
BEGIN { FS = "," }
{ gsub(/"/, "") }
$1 != stratum || $6 != 1 { next }
$2 == "method=opencv" && $5 == 1 { keep($14, $8) } # the chart names it
$4 == peers && $2 != "always zero" && $2 != "method=opencv" { row[++n] = $0 }
END {
  print "time,error,low,high,p99,name"
  for (i = 2; i <= n; i++) # by time
    for (k = i; k > 1 && time(row[k]) < time(row[k - 1]); k--) { other = row[k]; row[k] = row[k - 1]; row[k - 1] = other }
  for (i = 1; i <= n; i++) {
    split(row[i], field, ",")
    if (best && field[8] >= best) continue
    best = field[8]
    name = field[2]
    sub(/ back$/, "", name)
    sub(/^DIS .*/, "DIS", name)
    if (name != last && has_room(field[14], field[8])) { last = name; keep(field[14], field[8]) } else name = ""
    print field[14] "," field[8] "," field[9] "," field[10] "," field[15] "," name
  }
}
function time(line, field) { split(line, field, ","); return field[14] + 0 }
function keep(x, y) { taken_x[++names] = x; taken_y[names] = y }
# A name is about a decade wide and a sixth of one high.
function has_room(x, y, i) {
  for (i = 1; i <= names; i++)
    if (decades(x, taken_x[i]) < 1.2 && decades(y, taken_y[i]) < 0.16) return 0
  return 1
}
function decades(a, b, d) { d = log(a / b) / log(10); return d < 0 ? -d : d }
