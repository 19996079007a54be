/PROG  PULSES
/ATTR
OWNER		= MNEDITOR;
DEFAULT_GROUP	= 1,*,*,*,*;
/MN
   1:  DO[1]=PULSE,0.2sec ;
   2:  DO[2]=PULSE ;
   3:  WAIT .30(sec) ;
   4:  RO[3]=PULSE,0.1sec ;
   5:  WAIT 1.00(sec) ;
   6:  $DEFPULSE=10 ;
   7:  DO[2]=PULSE ;
   8:  WAIT 2.00(sec) ;
/POS
/END
