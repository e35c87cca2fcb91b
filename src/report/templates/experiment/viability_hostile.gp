# q_min, q_max, dq_max: the limits of joint 1
@canvas 1000,780
set multiplot layout 3,1 title 'A source that demands too much, joint 1' @heading
@panel
set title 'position'
set ylabel 'q_d [rad]'
plot $data using 1:"wished [rad]" @line lc rgb series(2) title 'demanded', '' using 1:"q_d [rad]" @line lc rgb series(1) title 'q_d', \
  q_max @dashed lc rgb LIMIT title 'limit', q_min @dashed lc rgb LIMIT notitle
@panel
set title 'velocity'
set ylabel 'dq_d [rad/s]'
plot $data using 1:"dq_d [rad/s]" @line lc rgb series(1) notitle, \
  dq_max @dashed lc rgb LIMIT notitle, -dq_max @dashed lc rgb LIMIT notitle
@panel
set title 'margin to the border of the viable set'
set xlabel 't [s]'
set ylabel 'margin'
set yrange [-0.18:0.5]
plot $data using 1:"margin [-]" @line lc rgb series(1) notitle, \
  '' using (of("kept back [-]", 1, "t [s]")):(-0.06) @points lc rgb series(3) title 'kept back', \
  '' using (of("lost [-]", 1, "t [s]")):(-0.12) @points lc rgb series(5) title 'lost'
