@canvas 900,330
@panel
set title 'Delay of rate matching: stage on less stage off' @heading
set xlabel 'source [Hz]'
set ylabel 'delay [ms]'
set logscale x
plot $data using 1:"formula [ms]" @line lc rgb REFERENCE title '(N - 1)/2 T', \
  '' using 1:"position [ms]" @points lc rgb series(1) title 'position', \
  '' using 1:"velocity [ms]" @points lc rgb series(2) title 'velocity', \
  '' using 1:"torque [ms]" @points lc rgb series(3) title 'torque'
