@canvas 900,400
set multiplot layout 2,1
@panel
set xlabel 't [s]'
set ylabel 'force at the handle [N]'
plot $data using 1:2 @line lc rgb series(5) notitle
@panel
set xlabel 't [s]'
set ylabel 'energy into the port [mJ]'
plot for [axis = 1:3] $data using 1:axis + 2 @line lc rgb series(axis) title substr('xyz', axis, axis)
