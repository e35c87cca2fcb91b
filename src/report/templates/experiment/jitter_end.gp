# limit_ratio: acceleration limit / jerk limit of joint 1, s
T = 1e-3
@canvas 900,630
set multiplot layout 2,1 title 'Brisk trajectory at several paces: jitter 4 us, clocks 50 ppm apart' @heading
@panel
set title 'Largest jerk of all runs'
set xlabel 'largest acceleration / its limit'
set ylabel 'jerk / its limit'
plot $data using 1:(2*$1*limit_ratio/T) @dashed lc rgb REFERENCE title '2 ddq / T', \
  '' using 1:(1) @line lc rgb LIMIT title 'limit', \
  '' using 1:2 @line lc rgb RA title 'reference generator'
@panel
set title 'Runs that end in an abort'
set xlabel 'largest acceleration / its limit'
set ylabel 'aborted [%]'
plot $data using 1:(100*$3) @line lc rgb RS title 'runs aborted'
