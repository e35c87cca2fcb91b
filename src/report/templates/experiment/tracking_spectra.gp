@canvas 900,910
set multiplot layout 4,2 title 'red: synchronous + low-pass; amber: asynchronous; green: asynchronous + low-pass' @heading
do for [j = 1:7] {
  @panel
  set title sprintf('joint %d', j)
  set xlabel 'f [Hz]'
  set ylabel 'PSD of dq [(rad/s)^2/Hz]'
  set logscale xy
  plot $data using 1:(column(sprintf('rs_%d [rad^2/s^2/Hz]', j))) @line lc rgb RS notitle, \
    '' using 1:(column(sprintf('ra_%d [rad^2/s^2/Hz]', j))) @line lc rgb RA notitle, \
    '' using 1:(column(sprintf('ra_low_pass_%d [rad^2/s^2/Hz]', j))) @line lc rgb series(4) notitle, \
    '' using 1:(column(sprintf('rs_quiet_%d [rad^2/s^2/Hz]', j))) @dashed lc rgb REFERENCE notitle
}
