@canvas 900,450
@panel
set title 'Jerk of joint 1 caused by noise' @heading
set logscale xy
set xlabel 'amplitude [rad]'
set ylabel 'RMS jerk of joint 1 / its limit'
set yrange [1e-4:1e3]
# Raw and reference generator coincide: one of them is dashed.
plot $data using 1:"raw" @line lc rgb series(1) title 'raw', \
  '' using 1:"rate limiter" @line lc rgb series(2) title 'rate limiter', \
  '' using 1:"low-pass 100 Hz" @line lc rgb series(3) title 'low-pass 100 Hz', \
  '' using 1:"rate matching  source of 125 Hz" @line lc rgb series(4) title 'rate matching, source of 125 Hz', \
  '' using 1:"reference generator" @dashed lc rgb series(5) title 'reference generator', \
  '' using 1:"reference generator  velocity given" @line lc rgb series(6) title 'reference generator, velocity given'
