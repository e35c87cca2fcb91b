@canvas 1040,340
set multiplot layout 1,2
@panel
set title 'distribution'
set xlabel 'd_EXT on the wire [us]'
set ylabel 'share of commands in a bin [%]'
set logscale x
plot $data using 1:"in bin [%]" @steps lc rgb LF notitle
@panel
set title 'exceedance'
set xlabel 'd_EXT on the wire [us]'
set ylabel 'share of commands that took longer'
set logscale xy
plot $data using 1:"longer [1]" @line lc rgb LF notitle
