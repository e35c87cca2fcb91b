# simulated: whether the object's track is known
@canvas 900,300
@panel
set xlabel 't [s]'
set ylabel '[m]'
plot $data using 1:"x [m]" @line lc rgb series(1) title 'end effector x', \
  '' using 1:"y [m]" @line lc rgb series(2) title 'end effector y', \
  '' using 1:"z [m]" @line lc rgb series(3) title 'end effector z', \
  $object using 1:2 @dashed lc rgb LIMIT title simulated ? 'object z' : ''
