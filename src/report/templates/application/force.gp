@canvas 900,220
@panel
set xlabel 't [s]'
set ylabel 'force [N]'
plot $data using 1:2 @line lc rgb series(5) notitle
