# most: losses in a row that end a motion
@canvas 1040,240
@panel
set xlabel 'time in motion [s]'
set ylabel 'cycles'
plot $data using 1:2 @steps lc rgb RS title 'unserved in a row', most @dashed lc rgb LIMIT title 'ends the motion'
