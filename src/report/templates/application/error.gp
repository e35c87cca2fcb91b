@canvas 900,200
@panel
set xlabel 't [s]'
set ylabel 'error of the arm [mm]'
plot $data using 1:2 @line lc rgb series(4) notitle
