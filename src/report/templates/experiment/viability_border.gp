# dq_max, ddq_max: the limits of joint 1. The first rows have velocities over the acceleration, 402 for each number of losses; the
# others over the distance to the end of the range.
array losses[3] = [0, 3, 20]
label(n) = n == 0 ? 'no loss' : sprintf('%d lost in a row', n)
@canvas 1000,390
set multiplot layout 1,2 title 'Border of the viable set, joint 1' @heading
@panel
set title 'far from the ends of the range'
set xlabel 'acceleration [rad/s^2]'
set ylabel 'velocity [rad/s]'
set xrange [-1.1*ddq_max:1.1*ddq_max]
set yrange [-1.1*dq_max:1.1*dq_max]
plot for [i = 1:3] $data every ::0::3*402 - 1 using (of(1, losses[i], 2)):3 @line lc rgb series(i) title label(losses[i]), \
  for [i = 1:3] $data every 401::(i - 1)*402::i*402 - 1 using 2:3 @line lc rgb series(i) notitle
@panel
set title 'towards an end of the range, without acceleration'
set xlabel 'distance to the end [rad]'
set ylabel 'highest velocity [rad/s]'
set yrange [0:1.1*dq_max]
plot for [i = 1:3] $data every ::3*402 using (of(1, losses[i], 4)):3 @line lc rgb series(i) notitle
