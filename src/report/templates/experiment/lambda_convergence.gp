@canvas 900,330
set multiplot layout 1,2 title 'An offset between the reference and the last command' @heading
@panel
set title 'time until 5 % remain'
set xlabel 'lambda per cycle'
set ylabel 'time [s]'
set logscale xy
plot $data using "lambda":"formula [s]" @line lc rgb REFERENCE title 'ln 0.05 / ln(1 - lambda)', \
  '' using "lambda":"joint [s]" @points lc rgb LF title 'joint', \
  '' using "lambda":"rotation [s]" @points lc rgb RS title 'rotation'
@panel
set title 'largest jerk of an offset of 1 mrad'
set xlabel 'lambda per cycle'
set ylabel 'jerk [rad/s^3]'
set logscale xy
plot $data using "lambda":(1e-3*column("jerk per offset [1/s^3]")) @points lc rgb LF notitle
