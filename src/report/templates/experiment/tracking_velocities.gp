@canvas 900,910
set multiplot layout 4,2 title 'red: synchronous + low-pass; amber: asynchronous; green: asynchronous + low-pass' @heading
do for [j = 1:7] {
  @panel
  set title sprintf('joint %d', j)
  set xlabel 't [s]'
  set ylabel 'dq [rad/s]'
  plot $data using 1:(column(sprintf('rs_%d [rad/s]', j))) @line lc rgb RS notitle, \
    '' using 1:(column(sprintf('ra_%d [rad/s]', j))) @line lc rgb RA notitle, \
    '' using 1:(column(sprintf('ra_low_pass_%d [rad/s]', j))) @line lc rgb series(4) notitle, \
    '' using 1:(column(sprintf('planned_%d [rad/s]', j))) @dashed lc rgb REFERENCE notitle
}
