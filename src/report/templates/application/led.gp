@canvas 900,400
set multiplot layout 2,1
@panel
set xlabel 't [s]'
set ylabel 'base [m/s, rad/s]'
plot $data using 1:2 @line lc rgb series(1) title 'ahead', '' using 1:3 @line lc rgb series(2) title 'turning'
@panel
set xlabel 't [s]'
set ylabel 'arm''s reference [m/s]'
plot $data using 1:4 @line lc rgb series(3) notitle
