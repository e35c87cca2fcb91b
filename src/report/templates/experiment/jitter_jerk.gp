@canvas 900,630
set multiplot layout 2,1 title 'Jerk that jitter of 4 us makes, canonical trajectory' @heading
do for [interface in 'position velocity'] {
  @panel
  set title interface eq 'position' ? 'Position: dq* D3 dt / T^3' : 'Velocity: ddq* D2 dt / T^2'
  set xlabel 't [s]'
  set ylabel 'jerk of joint 1 [rad/s^3]'
  set xrange [1:1.06]
  plot $data using "t [s]":(column(interface . ' formula [rad/s^3]')) @line lc rgb REFERENCE title 'formula', \
    '' using "t [s]":(column(interface . ' measured [rad/s^3]')) @points lc rgb RS title 'reconstructed by INT'
}
