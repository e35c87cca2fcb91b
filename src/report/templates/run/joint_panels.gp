# names: title, unit, name of the reference, name of the measurement, title of each joint
# Per joint: y_min_1, y_max_1, the range; limit_min_1, limit_max_1. measured, limits: 1 if the plot has them.
@canvas 1200,1120
set multiplot layout 4,2 title names[1] @heading
@run_marks
do for [j = 1:7] {
  @panel
  set key off
  set lmargin 11; set rmargin 2; set tmargin 3; set bmargin 3
  set title names[4 + j] offset 0,-0.6
  set xlabel 'time / s' offset 0,0.6
  set ylabel names[2]
  set xrange [begin:end]
  set yrange [value(sprintf('y_min_%d', j)):value(sprintf('y_max_%d', j))]
  plot value(sprintf('limit_min_%d', j)) with lines dt 2 lw 1.5 lc rgb RUN_LIMIT, \
    value(sprintf('limit_max_%d', j)) with lines dt 2 lw 1.5 lc rgb RUN_LIMIT, \
    $measured using (of("joint", j, "t [s]")):3 with lines lw 3.5 lc rgb MEASURED, \
    $reference using (of("joint", j, "t [s]")):3 with lines lw 1.2 lc rgb DESIRED
}
# The eighth panel holds the legend, so that it hides no curve.
unset title; unset xlabel; unset ylabel; unset tics; unset border; unset grid; unset arrow; unset label
set key on center center vertical Left reverse font ',14' spacing 1.6 samplen 4
set xrange [0:1]
set yrange [0:1]
plot NaN with lines lw 2 lc rgb DESIRED title names[3], \
  NaN with lines lw 4 lc rgb MEASURED title measured ? names[4] : '', \
  NaN with lines dt 2 lw 2 lc rgb RUN_LIMIT title limits ? 'limit' : '', \
  NaN with lines dt 3 lw 1 lc rgb '#888888' title motions > 0 ? 'a motion begins, with its number' : '', \
  NaN with lines lw 2 lc rgb ABORT title aborted ? 'abort' : ''
