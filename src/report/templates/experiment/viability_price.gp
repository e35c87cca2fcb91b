@canvas 1200,350
set multiplot layout 1,3 title 'Price of the tolerated losses, joint 1' @heading
@panel
set title 'at full acceleration'
set xlabel 'commands lost in a row, n'
set ylabel 'highest speed [rad/s]'
plot $data using 1:2 @line lc rgb LF notitle
@panel
set title 'from full speed'
set xlabel 'commands lost in a row, n'
set ylabel 'stopping distance [rad]'
plot $data using 1:3 @line lc rgb LF notitle
@panel
set title 'from rest to rest'
set xlabel 'commands lost in a row, n'
set ylabel 'longer than with n = 0 [%]'
plot $data using 1:4 @line lc rgb series(1) title '0.05 rad', '' using 1:5 @line lc rgb series(2) title '0.3 rad', \
  '' using 1:6 @line lc rgb series(3) title '1.5 rad'
