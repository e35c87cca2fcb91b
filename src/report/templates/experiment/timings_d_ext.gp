@canvas 1040,340
set multiplot layout 1,2
@panel
set title 'distribution'
set xlabel 'd_EXT [us]'
set ylabel 'share of commands in a bin [%]'
set logscale x
plot for [loop in 'LF RS RA'] $data using 1:(column(loop.' in bin [%]')) @steps lc rgb value(loop) title loop
@panel
set title 'exceedance'
set xlabel 'd_EXT [us]'
set ylabel 'share of commands that took longer'
set logscale xy
plot for [loop in 'LF RS RA'] $data using 1:(column(loop.' above [1]')) @line lc rgb value(loop) title loop
