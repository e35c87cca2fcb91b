# The last cycles before an error, cycle 0 raised it: panels one below the other, and the fate of each command.
# $data: cycle, served, held, none, dropped, then a column for each curve. held_1, ...: the cycles that held
# names: title and unit of each panel; then name and colour of each curve; last, the name of a cycle without a command
# Of each panel p: low_p, high_p; its curves first_p to last_p; limit_p_1, limit_p_2, offender_p: NaN where there is none
# Of each curve c: points_c: single values instead of a line
@canvas 1040,170*(panels + 1)
set multiplot layout panels + 1,1
set lmargin 13; set rmargin 26; set tmargin 2; set bmargin 1.5
# To the right of the panel, where it hides nothing.
set key at screen 0.805,graph 0.98 left top vertical Left reverse maxcols 1 samplen 2 spacing 1.1 font ',12'
set format y '%.6g'; set format x ''
set xrange [begin - 0.7:0.7]
do for [i = 1:held] {
  held_at = value(sprintf('held_%d', i))
  set object rectangle from first held_at - 0.5,graph 0 to first held_at + 0.5,graph 1 fc rgb '#fbe3e5' fs solid noborder behind
}
set arrow from first 0,graph 0 to first 0,graph 1 nohead back lw 1 dt 3 lc rgb ABORT
is(x) = x == x
curve(c) = names[2*panels + 2*c - 1]
colour(c) = names[2*panels + 2*c]
points_of(c) = value(sprintf('points_%d', c))
do for [p = 1:panels] {
  first = value(sprintf('first_%d', p)); last = value(sprintf('last_%d', p))
  limit_1 = value(sprintf('limit_%d_1', p)); limit_2 = value(sprintf('limit_%d_2', p))
  offender = value(sprintf('offender_%d', p))
  set title names[2*p - 1] offset 0,-0.6
  set ylabel names[2*p] offset 0.5,0
  set yrange [value(sprintf('low_%d', p)):value(sprintf('high_%d', p))]
  plot for [c = first:last] $data using 1:(points_of(c) ? NaN : column(5 + c)) with linespoints pt 7 ps 0.25 lw 1.6 lc rgb colour(c) title (points_of(c) ? '' : curve(c)), \
    for [c = first:last] $data using 1:(points_of(c) ? column(5 + c) : NaN) with points pt 6 ps 0.6 lw 1.2 lc rgb colour(c) title (points_of(c) ? curve(c) : ''), \
    limit_1 with lines dt 2 lw 1.5 lc rgb RUN_LIMIT title (is(limit_1) ? 'limit' : ''), \
    limit_2 with lines dt 2 lw 1.5 lc rgb RUN_LIMIT notitle, \
    $data using 1:(column(1) == 0 ? offender : NaN) with points pt 7 ps 1 lc rgb ABORT title (is(offender) ? sprintf('raised it: %.6g', offender) : '')
}
set title 'what became of each command' offset 0,-0.6
set format x '%g'; set bmargin 3
# Four entries in one column.
set key spacing 0.9
set xlabel 'cycles of 1 ms, 0: the one that raised the error' offset 0,0.6
unset ylabel; set yrange [0:1.25]; set ytics ('' 0)
set style fill solid border lc rgb '#ffffff'
set boxwidth 1 absolute
plot $data using 1:2 with boxes fc rgb SERVED title 'served', $data using 1:3 with boxes fc rgb HELD title 'held', \
  $data using 1:4 with boxes fc rgb QUIET title names[|names|], \
  $data using 1:($5 > 0 ? 1.12 : NaN) with points pt 11 ps 0.9 lc rgb DESIRED title 'dropped'
