@canvas 900,300
@panel
set xlabel 't [s]'
set ylabel 'q, dashed q_d [rad]'
set xrange [0:span]
if (|$data| < 3) { set yrange [-1:1] }
plot for [j = 1:7] $data using "t [s]":(column(sprintf('q %d [rad]', j))) @line lc rgb series(j) title sprintf('%d', j), \
     for [j = 1:7] $data using "t [s]":(column(sprintf('q_d %d [rad]', j))) @dashed lc rgb series(j) notitle
