@canvas 900,830
set multiplot layout 4,2 title 'dq_d from a source at 125 Hz; red: off, blue: on' @heading
do for [j = 1:7] {
  @panel
  set title sprintf('joint %d', j)
  set xlabel 't [s]'
  set ylabel 'dq_d [rad/s]'
  plot $data using 1:(column(sprintf('off_%d [rad/s]', j))) @line lc rgb RS notitle, \
    '' using 1:(column(sprintf('on_%d [rad/s]', j))) @line lc rgb LF notitle
}
