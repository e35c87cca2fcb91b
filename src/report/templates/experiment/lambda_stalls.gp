# names: the chains; jerk_limit of joint 1, rad/s^3
colour(c) = word(LF.' '.RS.' '.RA, c + 1)
at(stall, chain) = column("stall [ms]") == stall && column("chain [-]") == chain ? column("t [s]") : NaN
@canvas 1000,550
set multiplot layout 2,2 title 'The source stops at t = 0' @heading
do for [stall in '50 200'] {
  @panel
  set title stall.' ms'
  set xlabel 't [s]'
  set ylabel 'velocity [rad/s]'
  set xrange [-0.1:1.5]
  plot $data using (at(stall, 0)):"planned [rad/s]" @dashed lc rgb REFERENCE title 'planned', \
    for [c = 0:2] $data using (at(stall, c)):"dq_d [rad/s]" @line lc rgb colour(c) title names[c + 1]
  @panel
  set title sprintf('%s ms, limit %.0f rad/s^3', stall, jerk_limit)
  set xlabel 't [s]'
  set ylabel 'jerk [rad/s^3]'
  set xrange [-0.1:1.5]
  set yrange [-1.5*jerk_limit:1.5*jerk_limit]
  plot for [c = 0:2] $data using (at(stall, c)):"jerk [rad/s^3]" @line lc rgb colour(c) notitle
}
