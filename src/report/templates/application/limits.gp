@canvas 900,440
set multiplot layout 2,1
@panel
set xlabel 't [s]'
set ylabel 'share of the limit [%]'
plot $data using 1:(100*column("velocity")) @line lc rgb series(1) title 'velocity', \
  '' using 1:(100*column("acceleration")) @line lc rgb series(2) title 'acceleration'
@panel
set xlabel 't [s]'
set ylabel 'jerk, share of the limit [%]'
plot $data using 1:(100*column("jerk")) @line lc rgb series(3) notitle
