@canvas 900,600
set multiplot layout 2,1
@panel
set xlabel 't [s]'
set ylabel 'q - q(0) [rad]'
plot for [j = 1:6] $data using 1:j + 1 @line lc rgb series(j) title sprintf('joint %d', j), \
  '' using 1:8 @dashed lc rgb series(1) title 'joint 7'
@panel
set xlabel 't [s]'
set ylabel 'end effector [mm]'
plot $data using 1:9 @line lc rgb LF notitle
